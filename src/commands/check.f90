!> limber check: a deck without a run. What a deck describes, without running it. Floor: commands.
module limber_commands_check
   use limber_base_error, only: error_type
   use limber_base_text, only: as_text, newline
   use limber_scene_first_scene, only: read_scene
   use limber_scene_scene, only: scene_type, mobility_line, inner_joints
   use limber_deck_parameters, only: override_type
   use limber_model_model, only: body_type, body_flexible, units_type
   implicit none
   private
   public :: check_deck

contains

   !> Reads, builds and assembles a deck, and says what it found.
   subroutine check_deck(path, overrides, report, error)
      character(*), intent(in) :: path
      !> Values of parameters in place of those of the deck
      type(override_type), intent(in) :: overrides(:)
      character(:), allocatable, intent(out) :: report
      type(error_type), allocatable, intent(out) :: error
      !> Of more bodies than this only the first ones and the last one are shown
      integer, parameter :: most_lines = 30, head = 10
      type(scene_type) :: scene
      integer :: i
      call read_scene(path, scene, error, overrides)
      if (allocated(error)) return
      associate (model => scene%system%model)
         report = scene%warnings//path//': '//model%heading
         do i = 1, size(model%bodies)
            if (size(model%bodies) > most_lines .and. i > head .and. i < size(model%bodies)) then
               if (i == head + 1) report = report//newline//'   ... '//as_text(size(model%bodies) - head - 1)//' bodies between'
               cycle
            end if
            if (model%bodies(i)%whole > 0) then
               associate (whole => model%wholes(model%bodies(i)%whole))
                  if (i == whole%first) report = report//newline//'   '//whole%name//' in '// &
                     & as_text(whole%last - whole%first + 1)//trim(merge(' beams;   ', ' segments;', allocated(whole%lean)))// &
                     & ' '//body_line(model%bodies(i), model%units)
               end associate
               cycle
            end if
            if (model%bodies(i)%control == 0) report = report//newline//'   '//body_line(model%bodies(i), model%units)
         end do
         report = report//newline//'   '//number_of(size(model%joints) - inner_joints(model), 'joint')//', '// &
            & number_of(size(model%drivers), 'driver')//', '//number_of(size(model%loads), 'load')//'; '// &
            & number_of(size(model%channels), 'channel')//newline//'   '//mobility_line(scene%assembly, inner_joints(model))
      end associate
   end subroutine check_deck

   !> '1 joint', '2 joints'.
   pure function number_of(count, word) result(text)
      integer, intent(in) :: count
      character(*), intent(in) :: word
      character(:), allocatable :: text
      text = as_text(count)//' '//word
      if (count /= 1) text = text//'s'
   end function number_of

   pure function body_line(body, units) result(line)
      type(body_type), intent(in) :: body
      type(units_type), intent(in) :: units
      character(:), allocatable :: line
      integer :: j
      line = body%name//': mass '//as_text(body%reduced%mass, 6)//' '//units%mass
      if (body%kind /= body_flexible) return
      line = line//', '//as_text(body%reduced%bending)//' bending and '//as_text(body%reduced%n - body%reduced%bending)// &
         & ' axial coordinates, rad/'//units%time//':'
      do j = 1, body%reduced%n
         line = line//' '//as_text(sqrt(body%reduced%omega2(j)), 4)
      end do
      if (allocated(body%note)) then
         if (body%note /= '') line = line//newline//'      '//body%note
      end if
   end function body_line

end module limber_commands_check
