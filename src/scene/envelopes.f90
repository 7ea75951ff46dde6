!> Envelopes of section forces. /bodies/<name>/envelope; those of a beam in segments are one. Floor: scene.
module limber_scene_envelopes
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_model_unit_rules, only: unit_text
   use limber_model_model, only: model_type
   use limber_model_beam_segments, only: pieces_of, piece_start, name_in_deck
   use limber_output_history, only: history_type
   use limber_output_internal_forces, only: section_forces_type
   implicit none
   private
   public :: record_envelope

contains

   !> Least and greatest values over all samples at the sections of a body, each (sections, 2) to h5py; a node has a section before
   !> it and one behind it. Of a beam in segments those of all pieces, with the first.
   subroutine record_envelope(model, body, efforts, history, error)
      type(model_type), intent(in) :: model
      !> Index of the body
      integer, intent(in) :: body
      !> Of all bodies
      type(section_forces_type), intent(in) :: efforts(:)
      type(history_type), intent(inout) :: history
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: group
      real(wp), allocatable :: extremes(:, :, :), place(:), member(:)
      integer :: pieces(2)
      pieces = pieces_of(model, body)
      if (.not. allocated(efforts(body)%extremes) .or. body > pieces(1)) return
      group = '/bodies/'//name_in_deck(model, body)//'/envelope'
      call gather()
      call history%put_real(group//'/member', member, '1', 'number of the member of each section in the deck; 1 of a beam', error)
      if (.not. allocated(error)) call history%put_real(group//'/coordinate', place, model%units%length, &
         & 'coordinate of each section along its beam or member', error)
      call put(1, 'axial_force', unit_text([1, -2, 1], model%units), 'tension')
      call put(2, 'shear_force', unit_text([1, -2, 1], model%units), 'shear force')
      call put(3, 'bending_moment', unit_text([2, -2, 1], model%units, .true.), 'bending moment')
      if (.not. all(model%bodies(body)%strength(3:4, :) > 0.0_wp)) return
      call put(4, 'stress_top', unit_text([-1, -2, 1], model%units), 'axial stress in the fibre to the left')
      call put(5, 'stress_bottom', unit_text([-1, -2, 1], model%units), 'axial stress in the fibre to the right')

   contains

      !> Sections and values of all pieces, one after another.
      subroutine gather()
         integer :: i, n, total
         total = 0
         do i = pieces(1), pieces(2)
            total = total + size(efforts(i)%extremes, 3)
         end do
         allocate (extremes(5, 2, total), place(total), member(total))
         total = 0
         do i = pieces(1), pieces(2)
            n = size(efforts(i)%extremes, 3)
            extremes(:, :, total + 1:total + n) = efforts(i)%extremes
            associate (before => model%bodies(i)%point_sections, all => model%bodies(i)%recovery%sections)
               associate (sections => all(before + 1:before + n))
                  place(total + 1:total + n) = piece_start(model, i) + sections%x
                  member(total + 1:total + n) = real(sections%member, wp)
                  call name_member(i, member(total + 1:total + n))
               end associate
            end associate
            total = total + n
         end do
      end subroutine gather

      !> Members of frames by their numbers in the deck; of a frame of beams the member is the beam.
      subroutine name_member(body, number)
         integer, intent(in) :: body
         real(wp), intent(inout) :: number(:)
         if (allocated(model%bodies(body)%member_numbers)) number = real(model%bodies(body)%member_numbers(nint(number)), wp)
         if (model%bodies(body)%whole == 0) return
         associate (whole => model%wholes(model%bodies(body)%whole))
            if (allocated(whole%member_numbers)) number = real(whole%member_numbers(body - whole%first + 1), wp)
         end associate
      end subroutine name_member

      subroutine put(row, name, unit, meaning)
         integer, intent(in) :: row
         character(*), intent(in) :: name, unit, meaning
         if (.not. allocated(error)) call history%put_real(group//'/'//name, extremes(row, :, :), unit, &
            & 'least and greatest '//meaning//' over all samples', error)
      end subroutine put

   end subroutine record_envelope

end module limber_scene_envelopes
