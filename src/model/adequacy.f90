!> Where joints, drivers and loads of a model act on its flexible bodies, and what the bases of these leave out there: for warnings
!> and for the choice of a basis. Floor: model. Source: doc/theory, eq. (135).
module limber_model_adequacy
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type
   use limber_flex_adequacy, only: static_residual
   use limber_flex_frame, only: frame_type, beam_frame
   use limber_flex_functions, only: attachment_type
   use limber_model_scene, only: model_type, body_type, body_flexible, joint_revolute, joint_point_on_line, joint_translational, &
      & joint_weld, joint_curve, joint_sliding, joint_gear, joint_rack, joint_belt, joint_coupler, coordinate_angle, effort_angle
   implicit none
   private
   public :: mark_acting, body_mesh, residuals_at_points

contains

   !> Points that forces, and those that couples act on.
   subroutine mark_acting(model, force, couple)
      type(model_type), intent(in) :: model
      !> (points of the model)
      logical, intent(out) :: force(:), couple(:)
      integer :: i, k
      force = .false.
      couple = .false.
      do i = 1, size(model%joints)
         associate (joint => model%joints(i))
            if (joint%kind == joint_coupler) then
               do k = 1, size(joint%terms)
                  if (joint%terms(k)%kind /= coordinate_angle) call along_joint(joint%terms(k)%of)
               end do
               cycle
            end if
            force(joint%points(1)) = .true.
            if (joint%kind == joint_sliding) cycle
            force(joint%points(2)) = .true.
            select case (joint%kind)
            case (joint_translational, joint_weld, joint_gear, joint_rack, joint_belt); couple(joint%points) = .true.
            case (joint_point_on_line, joint_curve); couple(joint%points(2)) = .true.
            end select
         end associate
      end do
      do i = 1, size(model%drivers)
         if (model%drivers(i)%joint > 0) call along_joint(model%drivers(i)%joint)
         call mark(model%drivers(i)%points, .false.)
      end do
      do i = 1, size(model%forces)
         force(model%forces(i)%point) = .true.
      end do
      do i = 1, size(model%springs)
         force(model%springs(i)%points) = .true.
      end do
      do i = 1, size(model%efforts)
         call mark(model%efforts(i)%points, model%efforts(i)%along == effort_angle)
      end do

   contains

      subroutine along_joint(joint)
         integer, intent(in) :: joint
         call mark(model%joints(joint)%points, model%joints(joint)%kind == joint_revolute)
      end subroutine along_joint

      subroutine mark(points, turning)
         integer, intent(in) :: points(2)
         logical, intent(in) :: turning
         integer :: k
         do k = 1, 2
            if (points(k) == 0) cycle
            if (turning) couple(points(k)) = .true.
            if (.not. turning) force(points(k)) = .true.
         end do
      end subroutine mark

   end subroutine mark_acting

   !> The mesh of a flexible body and the shapes of its coordinates (3, nodes, n).
   pure subroutine body_mesh(body, frame, shape)
      type(body_type), intent(in) :: body
      type(frame_type), intent(out) :: frame
      real(wp), allocatable, intent(out) :: shape(:, :, :)
      if (body%is_frame) then
         frame = body%mesh
         allocate (shape, source=body%shape)
      else
         call beam_frame(body%beam, body%choice%support, body%choice%origin, body%field, frame, shape)
      end if
   end subroutine body_mesh

   !> Displacements that unit forces and couples make where something acts on a body, and what its coordinates leave out of them,
   !> eq. (135). Nothing of a body that is rigid.
   subroutine residuals_at_points(model, body, points, parts, whole, left_out, error)
      type(model_type), intent(in) :: model
      !> Its index
      integer, intent(in) :: body
      !> Indices of the points, and 1, 2: force along the first or second axis of the body, 3: couple
      integer, allocatable, intent(out) :: points(:), parts(:)
      !> [length/force], [1/(force length)] of couples
      real(wp), allocatable, intent(out) :: whole(:), left_out(:)
      type(error_type), allocatable, intent(out) :: error
      logical :: force(size(model%points)), couple(size(model%points))
      type(attachment_type), allocatable :: at(:)
      type(frame_type) :: frame
      real(wp), allocatable :: shape(:, :, :)
      integer :: i, k, n
      allocate (points(3*size(model%points)), parts(3*size(model%points)))
      n = 0
      if (model%bodies(body)%kind == body_flexible) then
         call mark_acting(model, force, couple)
         do i = 1, size(model%points)
            if (model%points(i)%body /= body .or. model%points(i)%member == 0) cycle
            do k = 1, 3
               if (.not. merge(couple(i), force(i), k == 3)) cycle
               n = n + 1
               points(n) = i
               parts(n) = k
            end do
         end do
      end if
      points = points(:n)
      parts = parts(:n)
      allocate (at(n), whole(n), left_out(n))
      if (n == 0) return
      do i = 1, n
         at(i) = attachment_type(model%points(points(i))%member, model%points(points(i))%along, parts(i))
      end do
      call body_mesh(model%bodies(body), frame, shape)
      call static_residual(frame, shape, model%bodies(body)%reduced%omega2, at, whole, left_out, error)
   end subroutine residuals_at_points

end module limber_model_adequacy
