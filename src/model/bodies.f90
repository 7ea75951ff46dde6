!> Rigid bodies, point masses and named points from the deck, and what bodies of all kinds share. Floor: model.
module limber_model_bodies
   use limber_base_kinds, only: wp, long
   use limber_deck_content, only: block_type
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_flex_mesh, only: field_bytes
   use limber_flex_reduced, only: rigid_reduced, bytes_of
   use limber_model_lists, only: append
   use limber_model_points, only: add_point, enter_name, find_named
   use limber_model_scene, only: model_type, body_type, body_point, body_rigid
   implicit none
   private
   public :: add_rigid_body, add_point_mass, add_points, new_body, append_body, is_new_point, memory_of

contains

   !> The guess of a body's place and motion, common to all kinds.
   function new_body(block, kind) result(body)
      type(block_type), intent(in) :: block
      integer, intent(in) :: kind
      type(body_type) :: body
      body%name = block%name()
      body%kind = kind
      body%position = [block%real('X'), block%real('Y')]
      body%velocity = [block%real('VX'), block%real('VY')]
      body%angle = block%real('ANGLE')
      body%spin = block%real('SPIN')
   end function new_body

   subroutine add_rigid_body(block, model, diagnostics)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      type(body_type) :: body
      real(wp) :: centre(2)
      integer :: index
      body = new_body(block, body_rigid)
      centre = [block%real('CENTRE X'), block%real('CENTRE Y')]
      body%reduced = rigid_reduced(block%real('MASS'), block%real('INERTIA'), centre)
      if (block%real('INERTIA') > 0.0_wp .and. .not. block%real('MASS') > 0.0_wp) call diagnostics%warn( &
         & block%origin_of('INERTIA'), "body '"//body%name//"' has an inertia but no mass")
      call append_body(model, body, index)
      call add_point(model, body%name//'.origin', index, [0.0_wp, 0.0_wp])
      call add_point(model, body%name//'.centre', index, centre)
      call add_points(block, body%name, index, model, diagnostics)
      model%bodies(index)%size = extent(model, index)
   end subroutine add_rigid_body

   subroutine add_point_mass(block, model)
      type(block_type), intent(in) :: block
      type(model_type), intent(inout) :: model
      type(body_type) :: body
      integer :: index
      body = new_body(block, body_point)
      body%reduced = rigid_reduced(block%real('MASS'), 0.0_wp, [0.0_wp, 0.0_wp])
      call append_body(model, body, index)
      call add_point(model, body%name//'.origin', index, [0.0_wp, 0.0_wp])
   end subroutine add_point_mass

   !> Appends a body.
   subroutine append_body(model, body, index)
      type(model_type), intent(inout) :: model
      type(body_type), intent(in) :: body
      !> Its index
      integer, intent(out) :: index
      call append(model%bodies, model%counts%bodies, body)
      index = model%counts%bodies
      model%bytes = model%bytes + memory_of(body)
      call enter_name(model, 'body', body%name, index)
   end subroutine append_body

   !> Memory of the constants and shapes of a body [bytes].
   pure integer(long) function memory_of(body) result(bytes)
      type(body_type), intent(in) :: body
      bytes = bytes_of(body%reduced) + field_bytes(body%field)
      if (allocated(body%shape)) bytes = bytes + 8*size(body%shape, kind=long)
   end function memory_of

   !> Named points of the ground and of rigid bodies, `name, x, y` a line.
   subroutine add_points(block, owner, index, model, diagnostics)
      type(block_type), intent(in) :: block
      character(*), intent(in) :: owner
      integer, intent(in) :: index
      type(model_type), intent(inout) :: model
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i
      do i = 1, size(block%lines)
         associate (line => block%lines(i))
            if (.not. is_new_point(model, owner//'.'//line%text(1), line%origin_of(1), diagnostics)) cycle
            call add_point(model, owner//'.'//line%text(1), index, [line%number(2), line%number(3)])
         end associate
      end do
   end subroutine add_points

   !> Complains of a point that has the name of one that every body of its kind has. (What the deck names twice, the reader
   !> has complained of.)
   logical function is_new_point(model, name, origin, diagnostics)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(6), parameter :: own_names(5) = [character(6) :: 'origin', 'centre', 'start', 'middle', 'end']
      is_new_point = find_named(model, 'point', name) == 0
      if (is_new_point) return
      if (any(own_names == name(index(name, '.') + 1:))) call diagnostics%add(origin, &
         & "point '"//name//"' is there without being defined", 'choose another name')
   end function is_new_point

   !> Largest distance between two points of the body that was added last [length].
   pure real(wp) function extent(model, body)
      type(model_type), intent(in) :: model
      integer, intent(in) :: body
      integer :: i, j
      extent = 0.0_wp
      do i = model%counts%points, 1, -1
         if (model%points(i)%body /= body) exit
         do j = i - 1, 1, -1
            if (model%points(j)%body /= body) exit
            extent = max(extent, norm2(model%points(i)%p0 - model%points(j)%p0))
         end do
      end do
   end function extent

end module limber_model_bodies
